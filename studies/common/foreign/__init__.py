"""Foreign files for the study `one_run`: their source runs (`ground`), their `kinds`, the commands that must
refuse them (`readers`), and the test itself (`refusal`)."""
