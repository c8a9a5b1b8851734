// The options of a live figure as a map in order, and which of them go to its driver. Used by live.js and by its suite.

// "--scene teapot --shadows" as a map; a switch has the value true.
function parseArguments(args) {
  const map = new Map();
  const words = args.split(/\s+/).filter((word) => word);
  for (let i = 0; i < words.length; i++) {
    const value = words[i + 1] !== undefined && !words[i + 1].startsWith("--") ? words[++i] : true;
    map.set(words[i - (value === true ? 0 : 1)].slice(2), value);
  }
  return map;
}

function wordsOf(map) {
  return [...map].flatMap(([name, value]) => value === true ? [`--${name}`] : [`--${name}`, String(value)]);
}

// Of "leaf=0..255@|level", an option that a figure offers: its name, limits, and the values of --debug with which it
// goes, "" for none; null for all. rows: the driver's options, by --help.
function parseOffer(word, rows) {
  const [, name, limits, views] = word.match(/^([\w-]+)(?:=([^@]*))?(?:@(.*))?$/);
  const known = rows[name] && rows[name].views;
  return {name, limits, views: views !== undefined ? views.split("|") : known ? known.split(" ") : null};
}

function goesWith(offer, args) {
  return !offer.views || offer.views.includes(args.get("debug") || "");
}

// The arguments without those of other views.
function belonging(args, offers, rows) {
  const offered = new Map(offers.map((offer) => [offer.name, offer]));
  return new Map([...args].filter(([name]) => goesWith(offered.get(name) || parseOffer(name, rows), args)));
}
