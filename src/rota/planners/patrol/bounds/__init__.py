"""Proofs that a mission takes at least so many robots: one module per proof, and the best of them."""
