//! Nothing: the package stands for the features of its dependencies.
