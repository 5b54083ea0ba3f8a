"""Instances of systems with contacts, each with facts that it must reproduce."""
