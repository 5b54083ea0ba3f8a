"""Certificates of what pwmap found."""
