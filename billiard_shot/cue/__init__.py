"""The mechanical cue: where its joints go, how it strikes, and when it may."""
