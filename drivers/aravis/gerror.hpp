/// RAII types for GLib: object references as unique_ptr, and conversion of GError to Error.
#pragma once

#include <arv.h>

#include <memory>
#include <string>
#include <string_view>

#include "core/base/printable.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct GObjectUnref {
  void operator()(void* object) const { g_object_unref(object); }
};
struct GFree {
  void operator()(const void* memory) const { g_free(const_cast<void*>(memory)); }
};
template <class T>
using GRef = std::unique_ptr<T, GObjectUnref>;

/// Owner of the GError that a GLib call may set.
class GErrorSlot {
 public:
  GErrorSlot() = default;
  GErrorSlot(const GErrorSlot&) = delete;
  GErrorSlot& operator=(const GErrorSlot&) = delete;
  ~GErrorSlot() { g_clear_error(&error_); }

  GError** out() { return &error_; }
  explicit operator bool() const { return error_ != nullptr; }

  /// Whether the camera did not answer within Aravis's retries (2.5 s) or is disconnected.
  bool is_connection_loss() const {
    return error_ && error_->domain == ARV_DEVICE_ERROR &&
           (error_->code == ARV_DEVICE_ERROR_TIMEOUT ||
            error_->code == ARV_DEVICE_ERROR_NOT_CONNECTED ||
            error_->code == ARV_DEVICE_ERROR_TRANSFER_ERROR);
  }

  /// `doing`: the action that failed, e.g. "reading Gain". The caller sets the field.
  Error to_error(Errc code, std::string_view doing) const {
    return {code, "",
            std::string(doing) + " failed: " +
                (error_ ? printable(error_->message, kMaxReasonBytes) : "no reason given")};
  }

 private:
  static constexpr std::size_t kMaxReasonBytes = 500;
  GError* error_ = nullptr;
};

}  // namespace ovws
