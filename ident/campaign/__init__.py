"""What the lab measured: reading campaigns, checking them, their drive signals and noise floors."""

from .campaign import Campaign as Campaign
from .campaign import Prior as Prior
from .device import Device as Device
from .device import Oscillator as Oscillator
from .device import Platform as Platform
from .drive import drive_frequency as drive_frequency
from .drive import half_step_drive as half_step_drive
from .noise.floor import noise_floor as noise_floor
from .quality.judge import Judgement as Judgement
from .quality.judge import judge as judge
from .read import read_campaign as read_campaign
from .record import Channel as Channel
from .record import NoiseFloor as NoiseFloor
from .record import Record as Record
from .record import Sweep as Sweep
from .record import Trace as Trace
