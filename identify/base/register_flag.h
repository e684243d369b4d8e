// Flags of a program that are fields of a struct.
#ifndef CLOTHID_IDENTIFY_BASE_REGISTER_FLAG_H_
#define CLOTHID_IDENTIFY_BASE_REGISTER_FLAG_H_

#include <gflags/gflags.h>

namespace clothid {

// Has gflags bind --`name` to `field`, whose value is then the default. It keeps a pointer to the field and to a copy
// of the default as long as the process lasts.
template <typename Field>
void RegisterFlag(const char* name, const char* file, Field* field) {
  auto* const value_of_default = new Field(*field);
  gflags::FlagRegisterer(name, "", file, field, value_of_default);
}

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_REGISTER_FLAG_H_
