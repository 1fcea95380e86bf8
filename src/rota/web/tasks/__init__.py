"""What worker processes do: everything that takes time or memory."""
