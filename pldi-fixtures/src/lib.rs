#![doc = "Fixtures."]
