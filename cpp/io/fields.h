#pragma once
#include "fem/space.h"
#include "io/output_folder.h"
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace signorini::io {

/// Fields over time in an XDMF file and the HDF5 file beside it, at the mesh's own nodes (degree 2: their
/// values at the vertices) or one value for each cell, written one by one during a run. The HDF5 file has the
/// times in `/times` and the fields in `/Function/<field>/<number>`, numbers in the order of time, with
/// leading zeros so that names sort.
class FieldFile {
public:
  /// Vectors at the nodes or in the cells, and values of other shapes, which readers see as scalars and as
  /// tensors of 3 × 3.
  enum class Values { nodal, cellwise, nodal_scalar, cellwise_scalar, cellwise_tensor };

  /// Opens the file `name` (.xdmf), for `values` unless a write says otherwise. `fields`: the most datasets
  /// to be written, one per field and time; a tensor counts as three. Collective. The references must outlive
  /// this object. Throws UserError if the disk has no room for them, WriteFailure, on one rank or several, if
  /// the files cannot be written.
  FieldFile(const fem::Space& space, const OutputFolder& folder, const std::string& name, std::size_t fields,
            Values values = Values::nodal);
  /// Closes an open file on one rank only: on several ranks closing is collective, and the file is left as it
  /// is.
  ~FieldFile();
  FieldFile(const FieldFile&) = delete;
  FieldFile& operator=(const FieldFile&) = delete;

  /// Writes a field at `time` (s), in any order of times, the same times for all fields: its values that this
  /// rank owns, at the nodes of V or in the cells. Collective. Throws WriteFailure.
  void write(const std::string& field, std::span<const double> owned, double time, Values values);
  void write(const std::string& field, Vec values, double time);

  /// Closes the file and checks that it is complete. Collective. Throws WriteFailure, UserError.
  void close();

private:
  struct Open;
  /// Puts the fields in ascending order of times, as readers expect, under the names of the order, and adds
  /// the times. Throws UserError. On rank 0.
  void put_in_order() const;
  template <class Work>
  void guarded(Work&& work);

  const fem::Space& space_;
  const OutputFolder& folder_;
  std::string name_;
  Values values_;
  std::map<std::string, std::vector<double>> times_; ///< of each field, in the order of writing, s
  std::unique_ptr<Open> open_;                       ///< null once closed
};

} // namespace signorini::io
