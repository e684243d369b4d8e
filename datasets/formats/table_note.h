// What a reader made of a table that is not plain, for the user to know.
#ifndef CLOTHID_DATASETS_FORMATS_TABLE_NOTE_H_
#define CLOTHID_DATASETS_FORMATS_TABLE_NOTE_H_

#include <string>

namespace clothid {

// `Table::note` (sim/base/table.h) by the first lines of a file; of a TRC file, that it has decimal commas. Empty for
// plain tables and for what is no table: a file of another extension than that of text, or that cannot be read.
std::string TableNote(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_TABLE_NOTE_H_
