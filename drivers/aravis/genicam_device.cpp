/// GenICam feature access through Aravis; every answer is checked.
#include "drivers/aravis/genicam_device.hpp"

#include <cmath>
#include <utility>

#include "drivers/aravis/gige_probe.hpp"

namespace ovws {

namespace {

void on_control_lost(ArvDevice*, gpointer alive) {
  static_cast<std::atomic<bool>*>(alive)->store(false, std::memory_order_relaxed);
}

}  // namespace

GenicamDevice::GenicamDevice(GRef<ArvDevice> device) : device_(std::move(device)) {
  control_lost_ =
      g_signal_connect(device_.get(), "control-lost", G_CALLBACK(on_control_lost), &alive_);
}

GenicamDevice::~GenicamDevice() {
  g_signal_handler_disconnect(device_.get(), control_lost_);
}

template <class Call>
auto GenicamDevice::ask(const char* verb, const char* feature, Call call)
    -> Result<decltype(call(static_cast<GError**>(nullptr)))> {
  if (!alive())
    return fail(Errc::device, "", "the camera no longer answers: check its cable and power");
  GErrorSlot error;
  Result<decltype(call(error.out()))> answer;
  if constexpr (std::is_void_v<decltype(call(error.out()))>) {
    call(error.out());
  } else {
    answer = call(error.out());
  }
  if (!error) return answer;
  if (error.is_connection_loss()) alive_.store(false, std::memory_order_relaxed);
  return fail(error.to_error(Errc::device, std::string(verb) + " " + feature));
}

Result<void> GenicamDevice::check_control() {
  if (!is_gige()) return {};
  guint32 privilege = 0;
  auto answer = ask("reading", "who controls the camera", [&](GError** error) {
    return arv_device_read_register(device_.get(), kControlRegister, &privilege, error);
  });
  if (!answer) return fail(answer.error());
  if ((privilege & kControlBits) != 0) return {};
  give_up();
  return fail(Errc::device, "", kCameraWasReset);
}

bool GenicamDevice::has(const char* feature) {
  return ask("looking for", feature,
             [&](GError** error) {
               return arv_device_is_feature_available(device_.get(), feature, error) != FALSE;
             })
      .value_or(false);
}

bool GenicamDevice::has_number(const char* feature) {
  ArvGcNode* node = arv_device_get_feature(device_.get(), feature);
  return (ARV_IS_GC_FLOAT(node) || ARV_IS_GC_INTEGER(node)) && has(feature);
}

Result<double> GenicamDevice::number(const char* feature) {
  const bool real = ARV_IS_GC_FLOAT(arv_device_get_feature(device_.get(), feature));
  return ask("reading", feature, [&](GError** error) {
    return real ? arv_device_get_float_feature_value(device_.get(), feature, error)
                : double(arv_device_get_integer_feature_value(device_.get(), feature, error));
  });
}

Result<Range<double>> GenicamDevice::range(const char* feature) {
  const bool real = ARV_IS_GC_FLOAT(arv_device_get_feature(device_.get(), feature));
  return ask("reading the limits of", feature, [&](GError** error) {
    Range<double> range;
    // A missing increment is no error: most float features have no increment.
    if (real) {
      arv_device_get_float_feature_bounds(device_.get(), feature, &range.min, &range.max, error);
      if (*error != nullptr) return range;
      const double step = arv_device_get_float_feature_increment(device_.get(), feature, nullptr);
      range.increment = step > G_MINDOUBLE ? step : 0.0;
    } else {
      gint64 min = 0, max = 0;
      arv_device_get_integer_feature_bounds(device_.get(), feature, &min, &max, error);
      if (*error != nullptr) return range;
      range = {double(min), double(max),
               double(arv_device_get_integer_feature_increment(device_.get(), feature, nullptr))};
    }
    return range;
  });
}

Result<void> GenicamDevice::set_number(const char* feature, double value) {
  const bool real = ARV_IS_GC_FLOAT(arv_device_get_feature(device_.get(), feature));
  return ask("setting", feature, [&](GError** error) {
    if (real)
      arv_device_set_float_feature_value(device_.get(), feature, value, error);
    else
      arv_device_set_integer_feature_value(device_.get(), feature, std::llround(value), error);
  });
}

Result<std::string> GenicamDevice::text(const char* feature) {
  return ask("reading", feature, [&](GError** error) {
    const char* value = arv_device_get_string_feature_value(device_.get(), feature, error);
    return std::string(value ? value : "");
  });
}

Result<std::vector<std::string>> GenicamDevice::choices(const char* feature) {
  return ask("reading the choices of", feature, [&](GError** error) {
    guint count = 0;
    const std::unique_ptr<const char*, GFree> names(
        arv_device_dup_available_enumeration_feature_values_as_strings(device_.get(), feature,
                                                                       &count, error));
    return names ? std::vector<std::string>(names.get(), names.get() + count)
                 : std::vector<std::string>();
  });
}

Result<void> GenicamDevice::set_text(const char* feature, const char* value) {
  return ask("setting", feature, [&](GError** error) {
    arv_device_set_string_feature_value(device_.get(), feature, value, error);
  });
}

Result<void> GenicamDevice::choose_if_offered(const char* feature, const char* choice) {
  if (!ARV_IS_GC_ENUMERATION(arv_device_get_feature(device_.get(), feature))) return {};
  auto offered = ask("reading the choices of", feature, [&](GError** error) {
    return arv_device_is_enumeration_entry_available(device_.get(), feature, choice, error) !=
           FALSE;
  });
  if (!offered) return fail(offered.error());
  if (!*offered) return {};
  return set_text(feature, choice);
}

Result<void> GenicamDevice::switch_if_offered(const char* feature, bool on) {
  if (!ARV_IS_GC_BOOLEAN(arv_device_get_feature(device_.get(), feature)) || !has(feature))
    return {};
  return ask("switching", feature, [&](GError** error) {
    arv_device_set_boolean_feature_value(device_.get(), feature, on ? TRUE : FALSE, error);
  });
}

Result<void> GenicamDevice::execute(const char* command) {
  return ask("executing", command,
             [&](GError** error) { arv_device_execute_command(device_.get(), command, error); });
}

}  // namespace ovws
