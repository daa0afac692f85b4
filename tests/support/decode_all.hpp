#pragma once

#include "proto/requests.hpp"
#include "proto/rpc.hpp"
#include "proto/tables/corrector.hpp"
#include "proto/tables/devices.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/lattices.hpp"
#include "proto/tables/picture.hpp"

namespace ovws::test {

/// Decodes params with the table of every method; none may throw.
inline void decode_all(const Json& params) {
  (void)CameraSet::decode(params);
  (void)SensorSet::decode(params);
  (void)ModesSet::decode(params);
  (void)decode<ReferenceTake>(params);
  (void)decode<ReferenceSet>(params);
  (void)decode<RegistrationRun>(params);
  (void)decode<ArrayFit>(params);
  (void)decode<LutRun>(params);
  (void)decode<FlatnessRun>(params);
  (void)decode<MapRun>(params);
  (void)decode<FocusRun>(params);
  (void)decode<CameraSelect>(params);
  (void)SlmSet::decode(params);
  (void)decode<ReferenceName>(params);
  (void)decode<LatticePrepare>(params);
  (void)decode<LatticeName>(params);
  (void)decode<ConfigSave>(params);
  (void)decode<SettleRun>(params);
  (void)decode<AutoExposure>(params);
  (void)decode<LoopSettings>(params);
  (void)decode<LoopIdentify>(params);
  (void)decode<LoopOpen>(params);
  (void)decode<LoopPause>(params);
  (void)decode<CalibrationRun>(params);
  (void)decode<CalibrationSet>(params);
  (void)decode<CorrectorSet>(params);
  (void)decode<SlmShow>(params);
  (void)decode<SlmPresent>(params);
  (void)decode<CameraGrab>(params);
  (void)decode<RecordStart>(params);
  (void)decode<JobNumber>(params);
  (void)decode<Nothing>(params);
}

}  // namespace ovws::test
