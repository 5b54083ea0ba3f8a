"""Examples of systems with contacts, each with known facts that it must reproduce."""
