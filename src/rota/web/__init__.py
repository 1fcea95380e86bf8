"""The page: a server that stays responsive, worker processes that do the work, and a store that outlives both."""
