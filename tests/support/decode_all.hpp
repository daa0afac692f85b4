#pragma once

#include "proto/experiment.hpp"
#include "proto/requests.hpp"
#include "proto/rpc.hpp"

namespace ovws::test {

/// Decodes params as every method would: none may throw.
inline void decode_all(const Json& params) {
  (void)decode_camera_set(params);
  (void)decode_sensor_set(params);
  (void)decode_aberration_set(params);
  (void)decode_reference_take(params);
  (void)decode_reference_set(params);
  (void)decode_registration_run(params);
  (void)decode_lut_run(params);
  (void)decode_flatness_run(params);
  (void)decode_slm_settle(params);
  (void)decode_loop_close(params);
  (void)decode_loop_open(params);
  (void)decode_calibration_run(params);
  (void)decode_gain_sweep(params);
  (void)decode_experiment_cell(params);
  (void)decode_slm_show(params);
  (void)decode_record_start(params);
  (void)decode_job(params);
  (void)decode_nothing(params);
}

}  // namespace ovws::test
