"""Planning jobs: their queue, their progress, and who listens."""
