// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/xdmf_index.h"
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>

namespace signorini::io {
namespace {

const char* attribute_type(Values values) {
  switch (values) {
  case Values::nodal:
  case Values::cellwise:
    return "Vector";
  case Values::cellwise_tensor:
    return "Tensor";
  default:
    return "Scalar";
  }
}

} // namespace

std::string numbered(std::size_t number) { return fmt::format("{:08}", number); }

XdmfIndex::XdmfIndex(std::string data, int dim, std::size_t nodes, std::size_t cells)
    : data_(std::move(data)), dim_(dim), nodes_(nodes), cells_(cells) {}

std::string XdmfIndex::begin() {
  return R"xml(<?xml version="1.0"?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="fields" GridType="Collection" CollectionType="Temporal">
)xml";
}

std::string XdmfIndex::time(std::size_t number, double time, std::span<const FieldSeries> fields) const {
  std::string text = fmt::format(R"xml(      <Grid Name="mesh" GridType="Uniform">
        <Time Value="{0}" />
        <Topology TopologyType="{1}" NumberOfElements="{2}" NodesPerElement="{3}">
          <DataItem Dimensions="{2} {3}" NumberType="Int" Precision="8" Format="HDF">{4}:/Mesh/mesh/topology</DataItem>
        </Topology>
        <Geometry GeometryType="{5}">
          <DataItem Dimensions="{6} {7}" NumberType="Float" Precision="8" Format="HDF">{4}:/Mesh/mesh/geometry</DataItem>
        </Geometry>
)xml",
                                 time, dim_ == 3 ? "Tetrahedron" : "Triangle", cells_, dim_ + 1, data_,
                                 dim_ == 3 ? "XYZ" : "XY", nodes_, dim_);
  for (const auto& [name, values] : fields)
    fmt::format_to(
        std::back_inserter(text), R"xml(        <Attribute Name="{0}" AttributeType="{1}" Center="{2}">
          <DataItem Dimensions="{3} {4}" NumberType="Float" Precision="8" Format="HDF">{5}:/Function/{0}/{6}</DataItem>
        </Attribute>
)xml",
        name, attribute_type(values), in_cells(values) ? "Cell" : "Node", in_cells(values) ? cells_ : nodes_,
        fmt::join(stored_shape(values), " "), data_, numbered(number));
  return text + "      </Grid>\n";
}

std::string XdmfIndex::end() { return "    </Grid>\n  </Domain>\n</Xdmf>\n"; }

} // namespace signorini::io
