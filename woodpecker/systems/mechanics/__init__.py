"""The equations of a system with contacts, and the laws of its impacts and modes."""
