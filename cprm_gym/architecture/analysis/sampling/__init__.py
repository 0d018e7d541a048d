"""What many runs show, and how sure that is (dissertation §3.3).

`intervals`: of a probability from counts, one at a time or several at once. `sequences`: intervals that hold however long one looks.
`sequential`: is it at least so much? `means`: intervals of returns, lengths, any number (`numbers`). `properties`: what a run shows, in
words of linear temporal and of signal temporal logic. `identity`: what a journal is of.
"""
