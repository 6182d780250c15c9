// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_request.h"
#include <nlohmann/json.hpp>

namespace signorini::mesh {

using nlohmann::json;

std::string packed(const GmshRequest& request) {
  const scene::Mesh& mesh = request.mesh;
  json all{{"file", mesh.file.string()},
           {"scale", mesh.scale},
           {"unit", static_cast<int>(mesh.unit)},
           {"keep", request.keep.string()}};
  if (mesh.size)
    all["size"] = *mesh.size;
  if (const auto& field = request.sizes)
    all["sizes"] = {
        {"dim", field->dim}, {"points", field->points}, {"cells", field->cells}, {"sizes", field->sizes}};
  if (request.written) {
    const std::string bytes = packed(*request.written);
    all["written"] = json::binary(std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
  }
  std::string bytes;
  json::to_cbor(all, bytes);
  return bytes;
}

GmshRequest request_of(const std::string& bytes) {
  const json all = json::from_cbor(bytes);
  GmshRequest request{.mesh{.file = all.at("file").get<std::string>(),
                            .size{},
                            .scale = all.at("scale"),
                            .unit = static_cast<scene::LengthUnit>(all.at("unit").get<int>())}};
  request.keep = all.at("keep").get<std::string>();
  if (const auto size = all.find("size"); size != all.end())
    request.mesh.size = size->get<double>();
  if (const auto field = all.find("sizes"); field != all.end())
    request.sizes = {.dim = field->at("dim"),
                     .points = field->at("points"),
                     .cells = field->at("cells"),
                     .sizes = field->at("sizes")};
  if (const auto written = all.find("written"); written != all.end()) {
    const auto& raw = written->get_binary();
    request.written = unpacked({reinterpret_cast<const char*>(raw.data()), raw.size()});
  }
  return request;
}

} // namespace signorini::mesh
