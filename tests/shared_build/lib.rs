//! Nothing: the package only asks for features of its dependencies.
