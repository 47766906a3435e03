"""Foreign files, for the study `one_run`: what they are made of (`ground`), their `kinds`,
who must refuse them (`readers`), and the test of one (`refusal`)."""
