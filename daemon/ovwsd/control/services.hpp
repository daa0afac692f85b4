/// The parts of the daemon that the handlers of the control socket use.
#pragma once

#include "config/config.hpp"
#include "core/rt/counters.hpp"
#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/actor/state_keeper.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/status_reporter.hpp"
#include "daemon/ovwsd/loop/closed_loop.hpp"
#include "daemon/ovwsd/procedures/experiment_archive.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/record/recorder.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

struct Services {
  const Config& config;                 ///< as the daemon was started with
  const Guarded<LoadedConfig>& loaded;  ///< as last loaded: at the start, or by a reload
  StateKeeper& state;
  CameraActor& camera;
  SensorKeeper& keeper;
  Jobs& jobs;
  Procedures& procedures;
  ExperimentArchive& experiments;
  ClosedLoop& loop;
  LiveRefiner& refiner;
  Recorder& recorder;
  StatusReporter& status;
  SlmLoop& slm;
  Counters& counters;
  ClientGuard& clients;
  Disk& disk;
};

}  // namespace ovws
