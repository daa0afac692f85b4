/// GLib's reference counts and errors, as this code base keeps them: unique_ptr and Result.
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

/// The place where one call leaves its GError.
class GErrorSlot {
 public:
  GErrorSlot() = default;
  GErrorSlot(const GErrorSlot&) = delete;
  GErrorSlot& operator=(const GErrorSlot&) = delete;
  ~GErrorSlot() { g_clear_error(&error_); }

  GError** out() { return &error_; }
  explicit operator bool() const { return error_ != nullptr; }

  /// The camera did not answer within Aravis's retries (2.5 s), or its cable is gone.
  bool is_silence() const {
    return error_ && error_->domain == ARV_DEVICE_ERROR &&
           (error_->code == ARV_DEVICE_ERROR_TIMEOUT ||
            error_->code == ARV_DEVICE_ERROR_NOT_CONNECTED ||
            error_->code == ARV_DEVICE_ERROR_TRANSFER_ERROR);
  }

  /// `doing` says what was tried, e.g. "reading Gain". The field is left to the caller.
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
