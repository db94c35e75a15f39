"""Exact arithmetic: ranks modulo primes, transfers in rational numbers, and proofs of both."""
