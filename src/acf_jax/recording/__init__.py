"""Recordings of a rig: reading them, finding the impacts, and cutting a gap data set from them."""

from acf_jax.recording.impacts import Impacts as Impacts
from acf_jax.recording.impacts import Refused as Refused
from acf_jax.recording.impacts import find_impacts as find_impacts
from acf_jax.recording.mapping import Mapping as Mapping
from acf_jax.recording.mapping import Source as Source
from acf_jax.recording.mapping import read_mapping as read_mapping
from acf_jax.recording.session import Session as Session
from acf_jax.recording.session import read_session as read_session
