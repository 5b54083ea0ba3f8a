"""Piecewise-smooth maps over two parameters: curves of special points, and regions between them."""
