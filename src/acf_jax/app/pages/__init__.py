"""The pages, a step a file; each makes HTML of what the session's folder holds."""
