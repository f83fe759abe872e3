"""The records that REST answers with and the live stream carries, but for those of attention
(:mod:`app.attention.reports`) and the stream's own (:mod:`app.console.live.messages`).

They are JSON as they are (:mod:`app.console.wire`); descriptions and the page's types are made of them
(:mod:`app.console.schema`).
"""
