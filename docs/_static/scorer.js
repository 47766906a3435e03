// Rank the pages that a search finds: recipes and guides first; studies and generated descriptions of worlds last.
var Scorer = {
  score: ([docname, , , , score]) => {
    if (/^(start|tutorials|how-to|gallery)/.test(docname)) return score + 6;
    return /^(project|evidence|results|reference\/(odd|environments)\/)/.test(docname) ? score - 6 : score;
  },
  // the other values are the defaults of Sphinx
  objNameMatch: 11, objPartialMatch: 6, objPrio: { 0: 15, 1: 5, 2: -5 }, objPrioDefault: 0,
  title: 15, partialTitle: 7, term: 5, partialTerm: 2,
};
