"""A fleet watched while it drives: where it is, how old each place's last sight is, and which period lapses when."""
