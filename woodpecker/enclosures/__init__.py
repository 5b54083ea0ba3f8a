"""The toy over a box of starts and parameters: every decision proved, every quantity enclosed.

Enclosures are balls of Arb, Taylor models in the parameter, and forms over a box.
"""
