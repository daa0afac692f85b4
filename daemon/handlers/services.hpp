/// What the handlers of the control socket may use.
#pragma once

#include "config/config.hpp"
#include "core/rt/counters.hpp"
#include "daemon/camera_actor.hpp"
#include "daemon/client_guard.hpp"
#include "daemon/disk.hpp"
#include "daemon/experiment_archive.hpp"
#include "daemon/guarded.hpp"
#include "daemon/instrument.hpp"
#include "daemon/jobs.hpp"
#include "daemon/live_refiner.hpp"
#include "daemon/loop/closed_loop.hpp"
#include "daemon/procedures/procedures.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/saved_config.hpp"
#include "daemon/state_keeper.hpp"
#include "daemon/status_reporter.hpp"

namespace ovws {

struct Services {
  const Config& config;                 ///< as the daemon was started with
  const Guarded<LoadedConfig>& loaded;  ///< as last loaded: at the start, or by a reload
  StateKeeper& state;
  CameraActor& camera;
  Instrument& instrument;
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
