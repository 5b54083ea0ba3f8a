"""Two parameters of a map: cells, curves of bifurcations, and the points in which they meet."""
