#include "daemon/shared/schemas/schemas.hpp"

#include <algorithm>
#include <cctype>

#include "config/tables.hpp"
#include "proto/field_schema.hpp"
#include "proto/json_text.hpp"
#include "proto/methods.hpp"
#include "proto/tables/advice.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/devices.hpp"
#include "proto/tables/experiment.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/lattices.hpp"
#include "proto/tables/picture.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/status.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {

/// Text of daemon/shared/schemas/examples.json:
/// {params: {METHOD: [...]}, results: {TABLE: ...}, messages: {TOPIC: ...}}.
extern const std::string_view kExamples;

namespace {

/// Title of a method: "Experiment: gain sweep" for "experiment.gain_sweep".
std::string title_of(std::string name) {
  name[0] = char(std::toupper(name[0]));
  std::replace(name.begin(), name.end(), '_', ' ');
  if (const std::size_t dot = name.find('.'); dot != std::string::npos) name.replace(dot, 1, ": ");
  return name;
}

template <class P, class R>
Schema schema_of_method(const Method<P, R>& method, const Json& examples) {
  Json params = schema_of<P>(SchemaOf::params), result = schema_of<R>(SchemaOf::result);
  params["examples"] = examples["params"].value(method.name, Json::array({Json::object()}));
  if (const auto found = examples["results"].find(kTable<R>.name);
      found != examples["results"].end()) {
    result["examples"] = Json::array({*found});
  }
  Json json{{"title", title_of(method.name)},
            {"description", method.description},
            {"params", std::move(params)},
            {"result", std::move(result)}};
  if (method.binary_params != nullptr) json["binary_params"] = method.binary_params;
  if (method.binary_result != nullptr) json["binary_result"] = method.binary_result;
  return {method.name, std::move(json)};
}

template <class M>
Schema schema_of_stream(const Stream<M>& stream, const Json& examples) {
  Json message = schema_of<M>(SchemaOf::result);
  message["title"] = title_of(stream.topic);
  message["description"] = stream.description;
  message["examples"] = Json::array({examples["messages"].at(stream.topic)});
  Schema schema;
  schema.name.append("stream.").append(stream.topic);
  schema.json = std::move(message);
  return schema;
}

std::vector<Schema> make_schemas() {
  const Json examples = json_of(kExamples);
  std::vector<Schema> all;
  std::apply([&](const auto&... one) { (all.push_back(schema_of_method(one, examples)), ...); },
             kMethods);
  std::apply([&](const auto&... one) { (all.push_back(schema_of_stream(one, examples)), ...); },
             kStreams);
  std::sort(all.begin(), all.end(),
            [](const Schema& a, const Schema& b) { return a.name < b.name; });
  return all;
}

}  // namespace

const std::vector<Schema>& schemas() {
  static const std::vector<Schema> kAll = make_schemas();
  return kAll;
}

const nlohmann::json& schema(std::string_view name) {
  static const Json kNone;
  for (const Schema& one : schemas()) {
    if (one.name == name) return one.json;
  }
  return kNone;
}

}  // namespace ovws
