#pragma once
#include "fem/space.h"
#include "io/output_folder.h"
#include <map>
#include <memory>
#include <string>

namespace signorini::io {

/// Fields over time in an XDMF file and the HDF5 file beside it, at the mesh's own nodes (degree 2: their
/// values at the vertices) or one value for each cell, written as the times go by.
class FieldFile {
public:
  enum class Values { nodal, cellwise };

  /// Opens the file `name` (.xdmf) for at most so many fields in all, one per name and time. Collective. The
  /// references must outlive this object. Throws UserError if the disk has no room for them, WriteFailure, on
  /// one rank or several, if the files cannot be written.
  FieldFile(const fem::Space& space, const OutputFolder& folder, const std::string& name, std::size_t fields,
            Values values = Values::nodal);
  /// A file that was not closed is left as it is: on several ranks closing is collective.
  ~FieldFile();
  FieldFile(const FieldFile&) = delete;
  FieldFile& operator=(const FieldFile&) = delete;

  /// At times in any order of each field. Collective. Throws WriteFailure.
  void write(const std::string& field, Vec values, double time);

  /// Collective. Throws WriteFailure, UserError.
  void close();

private:
  struct Open;
  /// Puts the fields' times in ascending order, as readers take them.
  void sort_times() const;
  template <class Work>
  void guarded(Work&& work);

  const fem::Space& space_;
  const OutputFolder& folder_;
  std::string name_;
  bool as_they_are_;      ///< vectors hold what the file takes
  std::size_t times_ = 0; ///< written, of all fields
  bool sorted_ = true;
  std::map<std::string, double> last_; ///< times of the fields written last
  std::unique_ptr<Open> open_; ///< null once closed
};

} // namespace signorini::io
