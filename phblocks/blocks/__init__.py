"""The kinds of parts a diagram is made of; one kind a file."""
