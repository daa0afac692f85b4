/// Encoding of the rare messages: refined, status and event.
#include <cmath>

#include "proto/encode.hpp"
#include "proto/json_text.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {

std::optional<double> rms_waves(const RefinedMessage& message) {
  if (!message.valid) return std::nullopt;
  double squares = 0.0;
  for (std::size_t k = 0; k < message.j.size(); ++k) {
    if (message.j[k] > 2) squares += message.coefficients[k] * message.coefficients[k];
  }
  return std::sqrt(squares);
}

std::string encode(const RefinedMessage& message) {
  return json_text(to_json(message));
}

std::string encode(const StatusMessage& message) {
  return json_text(to_json(StreamedStatus{message}));
}

std::string encode(const EventMessage& message) {
  return json_text(to_json(message));
}

}  // namespace ovws
