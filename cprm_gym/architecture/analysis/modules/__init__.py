"""Whether a behaviour module keeps the promises of its interface, and whether a net uses it well."""
