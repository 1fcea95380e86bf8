"""The stages of Sun et al. 2019 as the paper has them, each done by any algorithm: what the study's figures show."""
