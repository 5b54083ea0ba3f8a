"""The paper's Figures 4 to 12, one script for each."""
