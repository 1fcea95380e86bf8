"""What robots can do, behind one seam: metres of way into seconds, corners, and rounds as they are driven."""
