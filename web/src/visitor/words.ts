/** What the page for visitors says by itself, in the languages that it knows; all else is the tour's. Pure. */

export interface Words {
  /** Of the list of languages. */
  language: string;
  stop: (number: number, stops: number) => string;
  start: string;
  agree: string;
  decline: string;
  next: string;
  ask: string;
  /** Without a tour. */
  nothing: string;
  /** Before a tour that a press begins. */
  begin: string;
  /** Before a tour that the robot begins. */
  soon: string;
  follow: string;
  waits: string;
  moment: string;
  over: string;
  lost: string;
  notNow: string;
  tooOften: string;
}

const EN: Words = {
  language: "Language",
  stop: (number, stops) => `Stop ${number} of ${stops}`,
  start: "Begin the tour",
  agree: "Yes, please",
  decline: "No, thank you",
  next: "Go on",
  ask: "Ask the robot",
  nothing: "There is no tour now.",
  begin: "Welcome! Press the button, and the robot shows you round.",
  soon: "Welcome! The robot begins the tour soon.",
  follow: "Please follow the robot.",
  waits: "The robot waits for you.",
  moment: "One moment, please.",
  over: "The tour is over. For another one, scan the code on the robot.",
  lost: "No connection to the robot. Trying again…",
  notNow: "That cannot be done just now.",
  tooOften: "Please wait a moment.",
};

const FR: Words = {
  language: "Langue",
  stop: (number, stops) => `Étape ${number} sur ${stops}`,
  start: "Commencer la visite",
  agree: "Oui, volontiers",
  decline: "Non merci",
  next: "Continuer",
  ask: "Poser une question au robot",
  nothing: "Il n’y a pas de visite en ce moment.",
  begin: "Bienvenue ! Touchez le bouton, et le robot vous guide.",
  soon: "Bienvenue ! Le robot commence bientôt la visite.",
  follow: "Suivez le robot, s’il vous plaît.",
  waits: "Le robot vous attend.",
  moment: "Un instant, s’il vous plaît.",
  over: "La visite est terminée. Pour une autre, scannez le code sur le robot.",
  lost: "Pas de connexion au robot. Nouvel essai…",
  notNow: "Ce n’est pas possible pour l’instant.",
  tooOften: "Un instant, s’il vous plaît.",
};

const DE: Words = {
  language: "Sprache",
  stop: (number, stops) => `Station ${number} von ${stops}`,
  start: "Führung beginnen",
  agree: "Ja, gern",
  decline: "Nein, danke",
  next: "Weiter",
  ask: "Den Roboter fragen",
  nothing: "Gerade gibt es keine Führung.",
  begin: "Willkommen! Drücken Sie den Knopf, und der Roboter führt Sie.",
  soon: "Willkommen! Der Roboter beginnt die Führung bald.",
  follow: "Bitte folgen Sie dem Roboter.",
  waits: "Der Roboter wartet auf Sie.",
  moment: "Einen Moment, bitte.",
  over: "Die Führung ist zu Ende. Für eine andere scannen Sie den Code am Roboter.",
  lost: "Keine Verbindung zum Roboter. Neuer Versuch …",
  notNow: "Das geht gerade nicht.",
  tooOften: "Bitte warten Sie einen Moment.",
};

const ES: Words = {
  language: "Idioma",
  stop: (number, stops) => `Parada ${number} de ${stops}`,
  start: "Empezar la visita",
  agree: "Sí, por favor",
  decline: "No, gracias",
  next: "Seguir",
  ask: "Preguntar al robot",
  nothing: "Ahora no hay ninguna visita.",
  begin: "¡Bienvenidos! Pulsen el botón y el robot les guiará.",
  soon: "¡Bienvenidos! El robot empezará pronto la visita.",
  follow: "Sigan al robot, por favor.",
  waits: "El robot les espera.",
  moment: "Un momento, por favor.",
  over: "La visita ha terminado. Para otra, escaneen el código del robot.",
  lost: "Sin conexión con el robot. Probando de nuevo…",
  notNow: "Ahora no es posible.",
  tooOften: "Un momento, por favor.",
};

const KNOWN: Record<string, Words> = { en: EN, fr: FR, de: DE, es: ES };

/** In the language of `tag` ("fr-ca": French), else in English. */
export function wordsIn(tag: string): Words {
  return KNOWN[tag.toLowerCase().split("-")[0] ?? ""] ?? EN;
}
