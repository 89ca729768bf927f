#![doc = "Host."]
