"""What each address does: from a request to the library or a command, and back."""
