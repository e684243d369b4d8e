'use strict';
// The page of finished fits that were judged together.

fillVerdict(count(result.repetitions.recordings.length, 'finished fit'));
const sums = result.provenance.input_sha256.split(',');
fillOrigin([...originRows(result.provenance),
  ...result.repetitions.recordings.map(({name}, i) => [name, codeCell(`sha256 ${sums[i]}`)])]);
