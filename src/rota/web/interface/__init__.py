"""The HTTP interface described: its operations, the values that they take and give, and the OpenAPI document."""
