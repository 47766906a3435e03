"""Foreign files for the `one_run` study: their source runs (`ground`), their `kinds`, the commands that must
refuse them (`readers`), and the test itself (`refusal`)."""
