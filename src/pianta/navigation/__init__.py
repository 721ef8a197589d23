"""Where robots go in a building: route graphs, places to wait at, approach poses, and paths that cover rooms."""
