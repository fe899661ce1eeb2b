"""The geometrically exact beam: section, spaces, reference element, mesh, block and read-outs."""
