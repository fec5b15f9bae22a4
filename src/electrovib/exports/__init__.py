"""Export for other programs: Traces, netlists, waveforms."""
