//! Assembly: the loops over cells and facets.
