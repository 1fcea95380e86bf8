"""Worker processes as the server sees them: started, asked, watched and ended."""
