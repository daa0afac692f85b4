/// The parts of the daemon that the handlers of the control socket use.
#pragma once

#include "daemon/shared/guarded.hpp"

namespace ovws {

// Include the headers of the parts that you use: all of them take seconds to compile.
class CameraActor;
class ClientGuard;
class ClosedLoop;
struct Config;
class Counters;
class Disk;
class ExperimentArchive;
class Jobs;
class LiveRefiner;
struct LoadedConfig;
class Procedures;
class Recorder;
class SensorKeeper;
class SlmLoop;
class StateKeeper;
class StatusReporter;

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
