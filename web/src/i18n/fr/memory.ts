/** What the robot remembers, in French. */

export const memory = {
  Memory: "Mémoire",
  "Export (JSON)": "Exporter (JSON)",
  "Delete all…": "Tout supprimer…",
  "Delete all": "Tout supprimer",
  "All episodes are gone then.": "Tous les épisodes seront alors perdus.",
  "What happens, and what is expected": "Ce qui se passe et ce qui est attendu",
  expected: "attendu",
  "So it desires {name} ({intensity}).": "Il désire donc {name} ({intensity}).",
  "Nothing is remembered yet.": "Rien n’est encore en mémoire.",
  "The export has {count} older ones, too.": {
    one: "L’export contient aussi {count} épisode plus ancien.",
    other: "L’export contient aussi {count} épisodes plus anciens.",
  },
  "; helped by {names}": " ; avec l’aide de {names}",
  "Delete episode {id}": "Supprimer l’épisode {id}",
  "at {place}": "à {place}",
  someone: "quelqu’un",
  "person {number}": "personne {number}",
  "“{word}”": "« {word} »",
  "code {name}": "code {name}",
  "Nothing that is remembered is like this.": "Rien de ce qui est en mémoire n’y ressemble.",
  "Nothing happens.": "Il ne se passe rien.",
  "This is like episode {id} ({match} %), which has happened {count} times.": {
    one: "Cela ressemble à l’épisode {id} ({match} %), qui a eu lieu une fois.",
    other: "Cela ressemble à l’épisode {id} ({match} %), qui a eu lieu {count} fois.",
  },
  "{times}, last {ago}": "{times}, la dernière {ago}",
  "{count} events": { one: "{count} événement", other: "{count} événements" },
} as const;
