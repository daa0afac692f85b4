"""Client library of ovwsd: all methods and all streams, blocking and for asyncio. See the README.md beside this package."""
from .async_client import AsyncClient
from .async_subscription import AsyncSubscription
from .client import Client
from .corrector import MirrorCalibration, MirrorLoop, calibrate_mirror, calibrate_sensor, set_matrix
from .errors import ClientError, JobFailed, Lost, NoAnswer, NotUnderstood, Refused
from .job import Job
from .lattice import px_per_slope, subaperture_centres
from .measured import MeanWavefront
from .messages import Corrector, Event, Image, Message, Phase, Refined, Spots, Status, Wavefront
from .methods import LEFT_OUT, LeftOut
from .mode_names import MODE_NAMES
from .modes import mode_index, mode_name
from .pictures import Grabbed, Presentation, grab
from .stream import Stream
from .subscription import Subscription
from .tilts import TiltReference, reference_from_tilts
from .wire import use_keys
from .zernike import orders, osa_index, phase_map_waves, pupil_grid, zernike

__all__ = [
    "LEFT_OUT", "MODE_NAMES", "AsyncClient", "AsyncSubscription", "Client", "ClientError", "Corrector", "Event", "Grabbed", "Image", "Job",
    "JobFailed", "LeftOut", "Lost", "MeanWavefront", "Message", "MirrorCalibration", "MirrorLoop", "NoAnswer", "NotUnderstood", "Phase",
    "Presentation", "Refined", "Refused", "Spots", "Status", "Stream", "Subscription", "TiltReference", "Wavefront", "calibrate_mirror",
    "calibrate_sensor", "grab", "mode_index", "mode_name", "orders", "osa_index", "phase_map_waves", "pupil_grid", "px_per_slope",
    "reference_from_tilts", "set_matrix", "subaperture_centres", "use_keys", "zernike",
]
