"""Where work runs that can be done side by side: ``concurrent.futures.Executor`` for processes and for clusters."""
