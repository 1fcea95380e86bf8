"""Orders in which robots come to places for ever, each again before its deadline: numbers alone, no ground."""
